"""What is shipped: export to ONNX, cards, the trained agents of the package."""
