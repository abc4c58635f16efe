"""What leaves and nodes of behaviour trees are made of: ports, action leaves, topics and suspension.

Behaviours for Python trees and nodes for XML trees build on it.
"""
