"""What else it could be: errors of laws, rivals, and what they leave open."""
