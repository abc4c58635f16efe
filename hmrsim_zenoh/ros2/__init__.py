"""The ROS 2 wire: hmrsim as rmw_zenoh's peers see it, without ROS.

Type descriptions, hashes and serialization all derive from the message models.
"""
