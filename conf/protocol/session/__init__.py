"""The sealed session beneath the messages: code, handshake, seal, replay, roaming. Pure, sans-IO.

Reading order: code.py, packet.py, replay.py, seal.py, handshake.py, initiator.py, responder.py, client.py, server.py.
"""
