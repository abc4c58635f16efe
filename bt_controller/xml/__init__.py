"""XML trees: files of BehaviorTree.CPP version 4, read, checked and built with py_trees' own parser.

`source` reads the files, `document` finds the trees in them, `check` compares each with the nodes that there are,
`translation` says it as py_trees' parser wants it, `file_tree` builds the trees, and `wiring` looks what is connected.
"""
