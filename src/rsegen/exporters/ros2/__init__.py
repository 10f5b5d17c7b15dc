"""What every ROS 2 package has whatever maps are in it: manifest, build file, launch files, configurations, licence.

name of the package --common_files--> the text of each file

The launch files look for the maps beside them, so packages of one name can be joined: only the maps differ.
"""
