"""Tests of cached properties without locks."""

import threading

from stiction._caching import cached_property


def test_computing_a_cached_property_does_not_block_other_objects():
    begun, end = threading.Event(), threading.Event()

    class ObjectWithSlowProperty:
        waits = False

        @cached_property
        def value(self):
            if self.waits:
                begun.set()
                assert end.wait(60)
            return object()

    slow, quick = ObjectWithSlowProperty(), ObjectWithSlowProperty()
    slow.waits = True
    other = threading.Thread(target=lambda: slow.value)
    other.start()
    assert begun.wait(60)
    values = []
    mine = threading.Thread(target=lambda: values.append(quick.value))
    mine.start()
    mine.join(60)
    assert values == [quick.value]
    end.set()
    other.join()
    assert slow.value is slow.value
    assert isinstance(ObjectWithSlowProperty.value, cached_property)
