"""From camera or clip to datagrams: frame sources, tracker, pose, calibration and the sending loop."""
