"""The night between gateways and pages: requests down, plans and observations up."""
