"""Robots in files of their makers: each format becomes one model of SDF, from which all else is read.

    SDF, with its includes ----------------.
    MJCF ---> compiled by MuJoCo ----------+--> <model>, checked --> places and masses, drive, motors --> SdfRobot
    Xacro --> URDF, with ROS's controllers-'    (sdf_names)          (sdf_shapes, sdf_drives, ...)        (sdf_file)

An `SdfRobot` writes its model again for each Gazebo: made drivable (`drivable`), and as that Gazebo reads it
(`gazebo_models`, `simulator_shapes`).
"""
