"""What several commands share: options and their values, tables, interruption, child processes."""
