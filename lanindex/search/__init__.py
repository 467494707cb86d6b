"""Text to Pattern to Hit."""
