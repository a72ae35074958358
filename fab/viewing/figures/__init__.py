"""Figures and movies about the method: what a flap angle decides, and how sheets grow and fold.

Each takes data of the solver, and gives a `Drawing` or a `Movie`.

- `vertices`: one vertex, its curve, its special choices, where its faces cross.
- `strips`: two vertices and more, their flap angles, folds and length bounds.
- `landscapes`: what each flap angle of a front costs, and which of them are forbidden.
- `loops`: for which flap angles a closed front closes.
- `growing`: a sheet strip by strip; `galleries`: many sheets at once; `ribbons`: along walks.
- `folds`: a sheet from flat to folded.
- `canvas` has what all of them draw on; `forms` draws faces in space, `sheets` whole sheets,
  `circles` arcs of flap angles.
"""
