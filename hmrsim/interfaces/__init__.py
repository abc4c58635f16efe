"""The ROS messages of the wire: one module per ROS package, one pydantic model per message.

The models are the only definition: JSON, JSON Schema, ROS type description and hash derive from them.
"""
