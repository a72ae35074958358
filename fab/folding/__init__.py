"""Folding: simulation of a crease pattern from flat to its target, and the verdict on it.

- `strain` is that of faces: `fab.viewing` colours them by it.
- `simulation` folds a pattern and judges it: `fold_and_judge`, with `FoldSettings`.
- `bar_hinge_model` is the mechanical model, a `Framework` of bars and hinges; `quasi_static` folds
  it from rest to rest (`fold`, a `Folding`), `dynamics` by masses that move. `rest` brings a sheet
  to rest, by the systems of `newton_system`, also under `potentials` such as weight.
- `rotation_predictor` predicts far turns, `folding_path` finds a path for sheets that get stuck.
- `verdict` says whether a `Folding` reached its target: `judge`, a `Verdict`; `target_forms` which
  folded form that is, `tolerance` how exactly, `misplaced_vertices` where vertices are at fault.
- `folded_states` gives the states of rigid panels: `folded_states`, each a `FoldedState`;
  `rigid_states` finds those without bent faces, `rigid_angles` the fold angles of a rigid fold.
- `rigid_motion` says whether a sheet folds with flat faces, and how: `rigid_motion`, a
  `RigidMotion`; `freedom` counts its degrees of freedom, `rigid_folding` follows it,
  `rigid_findings` reports it. States that close and steps between them: `rigid_creases`.
"""
