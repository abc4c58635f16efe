"""Loading of the tree that a user names: a file of BehaviorTree.CPP version 4, or a function in a module.

`trees` is the entry point. `source` reads XML files and finds the trees in them, `check` compares each node with
its class, `builder` plans and builds the nodes, and `file_tree` checks the connections of their ports.
"""
