"""What `armside bench` times, one subject a file."""
