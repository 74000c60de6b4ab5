"""Tests of cached properties without locks."""

import threading

from stiction._caching import cached_property


def test_computing_a_cached_property_of_one_object_does_not_block_other_objects():
    has_begun, may_end = threading.Event(), threading.Event()

    class ObjectWithSlowProperty:
        waits = False

        @cached_property
        def value(self):
            if self.waits:
                has_begun.set()
                assert may_end.wait(60)
            return object()

    slow_object, quick_object = ObjectWithSlowProperty(), ObjectWithSlowProperty()
    slow_object.waits = True
    slow_thread = threading.Thread(target=lambda: slow_object.value)
    slow_thread.start()
    assert has_begun.wait(60)
    values = []
    quick_thread = threading.Thread(target=lambda: values.append(quick_object.value))
    quick_thread.start()
    quick_thread.join(60)
    assert values == [quick_object.value]
    may_end.set()
    slow_thread.join()
    assert slow_object.value is slow_object.value
    assert isinstance(ObjectWithSlowProperty.value, cached_property)
