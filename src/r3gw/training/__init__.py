"""Training one scene: photos in memory, schedule, optimizer, loop, history."""
