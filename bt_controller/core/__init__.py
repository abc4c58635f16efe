"""The base of leaves and nodes: ports, action leaves, topics, subtrees, and the robots of the simulator.

Behaviors for Python trees and nodes for XML trees build on it.
"""
