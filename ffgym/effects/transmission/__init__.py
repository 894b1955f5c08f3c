"""What lies between motor and link."""
