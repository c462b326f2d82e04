"""The links of gateways: what they send, and what is sent to them."""
