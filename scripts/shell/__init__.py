"""What every command shares: options, console, errors, interrupts."""
