"""Files of ORIPA and its relatives, which all list creases as lines of a few types.

`cp` reads and writes CP files, `opx` reads those of ORIPA, `ori` those of Oriedita and Orihime.
`lines` has what their types mean.
"""
