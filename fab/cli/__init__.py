"""The command line: `group` has the commands, one module for each family of them.

`console` speaks to the terminal, `inputs` reads what commands are given, `delivery` writes and sums
up what they made.
"""
