"""The files of a ROS 2 package that do not depend on its maps: manifest, build file, launch files, configurations."""
