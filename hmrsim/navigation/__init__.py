"""Routes on the waypoint graph: lanes, quickest ways, legs, motion as formulas of time and external planners.

Robots and traffic drive by it; map commands and planners ask it.
"""
