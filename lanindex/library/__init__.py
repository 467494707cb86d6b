"""Score to SQL and back."""
