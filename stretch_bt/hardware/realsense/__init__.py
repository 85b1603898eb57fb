"""RealSense depth cameras through pyrealsense2, in a process of their own."""
