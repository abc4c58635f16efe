"""The ROS 2 wire: hmrsim as rmw_zenoh's peers see it, without ROS.

Everything that is ROS's own here (type descriptions, hashes, serialisation) derives from the message models.
"""
