"""What observations contain: settings, cameras, noise, and how a world becomes an observation."""
