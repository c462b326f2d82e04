"""What is drawn, and the processes that are started: the configurator's outermost layer."""
