"""The viewer without an editor: tasks, stored demonstrations, and policies while they are evaluated."""
