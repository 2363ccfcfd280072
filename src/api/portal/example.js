// The example of the first opening: an answer that this version of the service has recorded (`example.json`). It needs no token.

export async function recordedExample() {
  const response = await fetch('/portal/example.json');
  if (!response.ok) throw new Error('The example is missing.');
  return response.json();
}

/** The recorded spectrum of a channel, up to a frequency [Hz]. */
export function recordedSpectrum(spectra, channel, kind, limit) {
  const one = spectra.find((spectrum) => spectrum.channel === channel && spectrum.kind === kind);
  const count = one.frequency_hz.findLastIndex((frequency) => frequency <= limit) + 1;
  return { ...one, frequency_hz: one.frequency_hz.slice(0, count), amplitude: one.amplitude.slice(0, count) };
}
