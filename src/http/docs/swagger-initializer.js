// Swagger UI keeps the body when another media type is chosen; the fields of a form are no program.
const anotherBody = () => ({
  "statePlugins": {
    "oas3": {
      "wrapActions": {
        "setRequestContentType": (original, system) => (chosen) => {
          const action = original(chosen);
          system.oas3Actions.setRequestBodyValue({ "value": undefined, "pathMethod": chosen.pathMethod });
          return action;
        },
      },
    },
  },
});

window.onload = function () {
  window.ui = SwaggerUIBundle({
    "dom_id": "#swagger-ui",
    "url": "/openapi.json",
    "deepLinking": true,
    // At first sight there are the operations. Each of them has its schemas.
    "defaultModelsExpandDepth": -1,
    // Otherwise the page sends its document to a validator on the internet.
    "validatorUrl": "none",
    "layout": "StandaloneLayout",
    "presets": [SwaggerUIBundle.presets.apis, SwaggerUIStandalonePreset],
    "plugins": [SwaggerUIBundle.plugins.DownloadUrl, anotherBody],
  });
};
