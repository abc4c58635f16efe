"""The life of goals: who serves which action, acceptance, preemption, cancellation and results.

The simulation gives every command about a goal to the dispatcher here.
"""
