"""What the readers of a file make of its points: of the form, and of the follower's motion."""
