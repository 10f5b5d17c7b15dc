"""A map as it is to be seen: its field with colours, friction and looks, which every exporter starts from."""
