"""Finding the tree that a user names: a file of BehaviorTree.CPP, or a function in a module.

The command line and tests load trees through it.
"""
