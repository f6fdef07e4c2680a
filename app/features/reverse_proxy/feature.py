"""What the reverse proxy's side adds: the program is served below any path."""

from app.feature import Feature, Late, SettingOption

SETTINGS = Late("app.features.reverse_proxy.settings:ReverseProxySettings")
FEATURE = Feature(
    name="reverse_proxy",
    about="serves the page below a path of a reverse proxy",
    settings=SETTINGS,
    run_options=(SettingOption("reverse_proxy.root_path", SETTINGS, metavar="PATH", replays=True),),
    gates=(Late("app.features.reverse_proxy.below_path:gates"),),
)
