"""The encrypted session beneath the messages: pairing code, handshake, sealing, replay protection, roaming. Sans-IO.

Reading order: pairing_code, packet, replay_window, seal, handshake, initiator, responder, client, server.
"""
