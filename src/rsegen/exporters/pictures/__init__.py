"""Pictures of maps: previews, and plots of a robot's paths."""
