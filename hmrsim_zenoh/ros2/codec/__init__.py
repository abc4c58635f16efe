"""ROS's types, made from the message models: how they are serialised, described and hashed, in each distribution."""
