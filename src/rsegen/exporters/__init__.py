"""Maps as the bytes of files: Gazebo worlds and models, other formats, build sheets and pictures.

Scene --export--> Bundle
"""
