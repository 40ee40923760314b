"""Pictures of a rig: the figures of the chapter, and an animation."""
