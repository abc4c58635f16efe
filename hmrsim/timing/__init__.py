"""How time moves: paced by the wall clock or granted in lockstep to the controllers that take part.

Hosts run a simulator through it; it also keeps results for as long as clients may ask for them.
"""
