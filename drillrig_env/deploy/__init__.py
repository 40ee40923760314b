"""A policy on hardware: one file, and what runs it at the control period with NumPy and onnxruntime alone."""
