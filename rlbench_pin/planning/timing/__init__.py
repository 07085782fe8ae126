"""From paths to trajectories, within the limits of joints and motors."""
