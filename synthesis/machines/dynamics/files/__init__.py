"""Files of a follower train's response: tables (train_csv) and diagrams (train_diagrams)."""
