"""A map as the content of files: worlds and models of Gazebo, formats of other programs, build sheets and pictures.

Scene --export--> Bundle
"""
