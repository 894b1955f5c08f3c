"""What pages of docs/agents tell of the settings of laws."""
