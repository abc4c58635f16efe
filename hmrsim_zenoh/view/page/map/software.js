/** Whether the browser draws by software, where a GPU's way of drawing canvases is many times as slow. */
export const SOFTWARE = drawsBySoftware();

function drawsBySoftware() {
  const gl = globalThis.document?.createElement('canvas').getContext('webgl');
  if (!gl) return true;
  const info = gl.getExtension('WEBGL_debug_renderer_info');
  const renderer = String(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
  gl.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(renderer);
}
