from conf.call.local_state import LocalState


def test_a_call_begins_with_camera_and_microphone_and_without_images_of_the_person() -> None:
    assert LocalState() == LocalState(camera=True, microphone=True, portrait=False, has_microphone=True)
