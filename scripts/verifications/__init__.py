"""What `armside verify` shows over many seeds, one claim a file."""
