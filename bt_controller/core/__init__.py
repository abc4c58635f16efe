"""The base of leaves and nodes: ports, action leaves, topics and suspension.

Behaviors for Python trees and nodes for XML trees build on it.
"""
