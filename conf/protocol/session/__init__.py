"""The encrypted session beneath the messages: pairing code, handshake, sealing, replay protection, roaming. Sans-IO.

Reading order: pairing_code, sequence, packet, replay_window, seal, paths, active_session, handshake,
initiator, responder, client, server, call_session.
"""
