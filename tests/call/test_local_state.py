from conf.call.local_state import LocalState


def test_a_call_begins_with_camera_and_microphone_and_without_images_of_the_person() -> None:
    assert LocalState() == LocalState(camera=True, microphone=True, portrait=False, has_microphone=True)


def test_a_face_is_shown_while_the_camera_is_on_and_works() -> None:
    assert LocalState().shows_face
    assert not LocalState(camera=False).shows_face and not LocalState(camera_fault="gone").shows_face
