"""What films are made of: a camera that circles, and several films side by side."""
