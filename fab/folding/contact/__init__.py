"""Contact of a sheet with itself while it folds: no faces pass through each other.

- `contact` is the energy, a `Contact` (`fab.folding.potentials.Potential`); `barrier` its barrier.
- `surface` says what may touch, and how near; `near_pairs` finds what does.
- `closest_points` are those of two parts, `free_share` how far they may move.
- `contact_fold` folds a sheet with it: `fold_in_contact`; `stops` says where it was stopped.
- `fold_orders` gives orders of folding, for sheets that are stopped when all creases fold at once.
"""
