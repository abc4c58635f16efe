"""The life cycle of goals: action servers, acceptance, preemption, cancellation and results.

The simulation gives every command about a goal to the dispatcher here.
"""
