"""A depth camera that plays a ROS 2 bag: `use: ros_bag` in a cell file."""

from stretch_bt_ros_bag.driver import BagCamera

__all__ = ["BagCamera"]
